"""The paper's public study data."""
