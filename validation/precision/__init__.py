"""Errors against time: what each engine's steps buy, over ladders of them."""
