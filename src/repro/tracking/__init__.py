"""The store of finished stages: identity, provenance, locks, index. Knows no physics."""
