"""The inverse problem: limits in, what each line of a data sheet may be out."""
