"""Record and replay study sessions as MCAP bags; experiments, tables and figures."""
