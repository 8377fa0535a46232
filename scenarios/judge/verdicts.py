"""What a run may come to. Without Drake, for who only passes runs on."""

PASSED, FAILED = "passed", "failed"
INTERRUPTED, ERROR, UNJUDGED = "interrupted", "error", "not judged"
TIMED_OUT = "timed out"
SKIPPED = "skipped"  # what it needs is not installed
