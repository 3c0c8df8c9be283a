"""What a person sees: widgets that are shown data and say what was asked of them."""
