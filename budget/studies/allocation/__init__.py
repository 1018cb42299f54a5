"""Allocation, the inverse problem: limits in, what each line may be out."""
