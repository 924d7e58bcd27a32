"""How a node's process begins: its command line, its help, and the network it joins."""
