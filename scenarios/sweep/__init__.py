"""Many runs of one scenario: studies, rollouts, their dataset and report; parameters fitted."""
