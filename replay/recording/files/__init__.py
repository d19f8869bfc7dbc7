"""File-level access for episode formats: HDF5, Parquet tables, archives."""
