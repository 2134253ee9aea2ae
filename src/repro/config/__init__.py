"""From words on a command line to a checked, typed configuration."""
