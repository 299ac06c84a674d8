"""What is known of an experiment at every time, and where everything is: what all moving pictures are made of."""
