"""Export of the errors of a device in the terms of filters and simulators."""
