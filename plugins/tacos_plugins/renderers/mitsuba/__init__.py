"""`renderer.mitsuba`: path tracing with Mitsuba 3, the reference `renderer.moderngl` is compared with."""
