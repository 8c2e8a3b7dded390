"""Measuring a camera by EMVA Standard 1288 from frames of even light and of darkness."""
