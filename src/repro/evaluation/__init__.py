"""Accuracy of a fitted model: errors, gauges, passivity, roll-outs, identifiability."""
