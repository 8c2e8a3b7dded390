"""Measuring a camera's noise from frames of grey bars."""
