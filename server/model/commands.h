// The commands of hapticd-model, one file each. A command is a function that adds its subcommand
// to the command line; its callback does the work, and throws as server/command_line/program.h
// says. Not RT.
#pragma once

#include <CLI/CLI.hpp>

namespace hapticd {

/// build: a sphere-tree from a mesh or a model.
void add_build_command(CLI::App& app);
/// make: the mesh of a model.
void add_make_command(CLI::App& app);
/// list: the models and their parameters.
void add_list_command(CLI::App& app);
/// inspect: what a tree holds, and how far it errs from a mesh.
void add_inspect_command(CLI::App& app);
/// check: whether scenes can be played.
void add_check_command(CLI::App& app);
/// explain: what scenes model and what they do not, its error, and what a tick costs.
void add_explain_command(CLI::App& app);

}  // namespace hapticd
