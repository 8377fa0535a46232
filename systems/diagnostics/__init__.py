"""What is wrong with a step, said once and with the mend."""
