"""The report of a diagnosis: where the gap lies, what causes it, what is left; pictures before words."""
