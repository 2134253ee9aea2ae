"""The store of finished stages: identity, provenance, locks, index. Independent of physics."""
