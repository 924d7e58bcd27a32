"""Study sessions as MCAP bags: recorded, read, repaired, replayed."""
