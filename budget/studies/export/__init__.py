"""What a filter or a simulator is told of a device: its figures in another's terms."""
