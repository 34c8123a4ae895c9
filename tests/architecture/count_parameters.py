#!/usr/bin/python3
"""Prints, for each folder of the product, how many functions it defines and how many of them have five or more parameters.

Counted as by check_classes.py: where a function is defined, templates as well, lambdas not."""
import collections
import os

import cpp_outline
import source_tree

MANY = 5


def rows(sources):
    """(folder, functions, of these with many parameters), tops and their folders sorted, and all at the end; sources: {path: text}."""
    all_functions, many = collections.Counter(), collections.Counter()
    for path, text in sources.items():
        top = path.split("/")[0]
        if top == "tests":
            continue
        functions = cpp_outline.read(text).functions
        for folder in {top, os.path.dirname(path), "all"}:
            all_functions[folder] += len(functions)
            many[folder] += sum(function.parameters >= MANY for function in functions)
    return [(folder, all_functions[folder], many[folder]) for folder in sorted(all_functions, key=lambda folder: (folder == "all", folder))]


def main():
    sources = {path: source_tree.read(path) for path in source_tree.files() if path.endswith((".h", ".cpp"))}
    print(f"{'folder':<32} {'functions':>9} {f'{MANY} or more':>10}")
    for folder, functions, many in rows(sources):
        print(f"{folder:<32} {functions:>9} {many:>5} {100 * many / max(functions, 1):>4.1f} %")


if __name__ == "__main__":
    main()
