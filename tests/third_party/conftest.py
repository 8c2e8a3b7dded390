"""The example project is tested as a project of its own, once installed; see test_example_plugin.py."""

collect_ignore = ["tacos-example-plugin"]
