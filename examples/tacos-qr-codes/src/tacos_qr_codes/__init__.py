"""QR codes on a shelf, and how many of them a camera reads."""
