"""What tasks that learn with torch have in common; importing its modules imports torch."""
