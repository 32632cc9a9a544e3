"""Attacks on everything that takes bytes, numbers or calls from outside, counted by what they end in.

seed -> one hostile input -> [worker: a process that may die] -> refused, ran; or crash, hang, traceback, nonsense

Each kind is one file with `prepare`, done once in a process, and `attack(prepared, random)`, which makes and throws one input.
The same seed is the same input: `python -m hostile KIND --first SEED --inputs 1` repeats it.
"""
