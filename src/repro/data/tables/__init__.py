"""Tables as people export them, from CSV or Parquet: read, converted to SI units, and checked."""
