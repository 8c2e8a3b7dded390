"""How well hypotheses explain the evidence, and with which parameters."""
