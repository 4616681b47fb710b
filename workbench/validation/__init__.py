"""What an argument must be, in one vocabulary for all rooms: the ground floor, which knows none of them.

words    a clean value of each kind, or its refusal in one sentence
kinds    what a type hint takes, and the words for it
shapes   how many entries an expression has, declared where its type is
doors    the decorator that holds the arguments of a public function or class against its hints
"""
