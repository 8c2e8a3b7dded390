"""What `procedure.diagnose` adds to the diagnosis: scores of a task, and what becomes of a decision."""
