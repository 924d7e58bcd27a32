"""Sessions as a folder in the Brain Imaging Data Structure (BIDS), which other labs' tools read."""
