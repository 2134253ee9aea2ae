"""From stored runs to tables, figures and pages, without loading a model."""
