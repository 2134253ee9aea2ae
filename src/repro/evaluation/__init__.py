"""What a fitted model is worth: errors, gauges, passivity, roll-outs, identifiability."""
