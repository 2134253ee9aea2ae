"""Loss and gradient of one member as compiled C, one file a kind of model."""
