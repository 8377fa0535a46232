"""What a run leaves behind: summary, figures, report."""
