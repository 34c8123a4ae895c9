// The commands of hapticd-oracle, one file each. A command is a function that adds its subcommand
// to the command line; its callback does the work, and throws as server/command_line/program.h
// says. Not RT.
#pragma once

#include <CLI/CLI.hpp>

namespace hapticd {

/// gesture: a gesture as data.
void add_gesture_command(CLI::App& app);
/// poses: the path of a gesture, tick by tick.
void add_poses_command(CLI::App& app);
/// path: what a recorded tool met on its way.
void add_path_command(CLI::App& app);
/// baseline: another method on the same poses.
void add_baseline_command(CLI::App& app);
/// descent: the tool's tree against a string, level by level.
void add_descent_command(CLI::App& app);
/// cases: a sphere beside and beyond the end of a string.
void add_cases_command(CLI::App& app);
/// measure: cost and error of settings.
void add_measure_command(CLI::App& app);
/// strings: force and pitch of the levels of a string.
void add_strings_command(CLI::App& app);
/// ticks: a gesture played, for profilers.
void add_ticks_command(CLI::App& app);
/// triangle: the force triangle of a deflected string.
void add_triangle_command(CLI::App& app);

}  // namespace hapticd
