"""The paper's experiments, the public study data, simulated participants, execution trials."""
