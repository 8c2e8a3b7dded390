"""Effects as hypotheses: which, with which parameters, and which of them look alike."""
