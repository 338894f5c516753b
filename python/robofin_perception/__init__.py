"""Networks that see where a coating is sanded, and pictures to train and test them on."""
