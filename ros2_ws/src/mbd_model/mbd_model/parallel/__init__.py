"""One way to compute many sessions or problems at once: processes of this machine, or an existing Dask cluster."""
