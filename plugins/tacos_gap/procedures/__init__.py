"""Additions of `procedure.diagnose` to the diagnosis: scores of a task, and the decision of a study."""
