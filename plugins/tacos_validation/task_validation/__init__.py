"""Whether cameras rank alike in two simulators, or in a simulator and what stands for reality."""
