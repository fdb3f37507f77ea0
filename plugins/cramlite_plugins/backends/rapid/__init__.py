"""ABB RAPID: a typed program as a module of text."""
