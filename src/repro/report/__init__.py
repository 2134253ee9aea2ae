"""From stored runs to tables, figures and verdicts: reads only what was stored, knows no physics."""
