// See command_line_fault.h.
#include "proto/hints/command_line_fault.h"

#include <algorithm>
#include <regex>
#include <sstream>
#include <vector>

#include "proto/hints/nearest_name.h"

namespace hapticd::hints {
namespace {

/// Commands, or options, of `app` and of the commands that were given.
// NOLINTNEXTLINE(misc-no-recursion): as deep as commands have commands
void collect(const CLI::App& app, bool options, std::vector<std::string>& names) {
  if (options) {
    for (const CLI::Option* option : app.get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  } else {
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  }
  for (const CLI::App* given : app.get_subcommands()) collect(*given, options, names);
}

/// What to write for the number with a decimal comma in `said`; empty where there is none.
std::string comma_hint(const std::string& said) {
  std::smatch number;
  if (!std::regex_search(said, number, std::regex("[0-9]+,([0-9]+)"))) return {};
  if (number.length(1) == 3) return " Give a number without commas.";  // may be thousands
  std::string pointed = number.str();
  pointed[pointed.find(',')] = '.';
  return " Write " + pointed + ", with a point.";
}

/// The nearest choice where `said` is of the kind "--arm: frm not in {off,light}."
std::string choice_hint(const std::string& said) {
  std::smatch parts;
  if (!std::regex_search(said, parts, std::regex("(\\S+) not in \\{([^}]*)\\}"))) return {};
  std::vector<std::string> choices;
  std::stringstream list(parts.str(2));
  for (std::string choice; std::getline(list, choice, ',');) choices.push_back(choice);
  return did_you_mean(parts.str(1), choices);
}

}  // namespace

std::string command_line_fault(const CLI::App& app, const CLI::Error& error) {
  std::string said = error.what();
  if (!said.ends_with('.')) said += '.';
  std::vector<std::string> unknown = app.remaining(true);
  std::erase(unknown, "--");
  const auto is = [&](CLI::ExitCodes code) {
    return error.get_exit_code() == static_cast<int>(code);
  };
  if (is(CLI::ExitCodes::ValidationError) || is(CLI::ExitCodes::ConversionError)) {
    return said + choice_hint(said) + comma_hint(said);
  }
  const bool misses_command = is(CLI::ExitCodes::RequiredError);
  if (unknown.empty() || !(misses_command || is(CLI::ExitCodes::ExtrasError))) return said;
  const auto dashed = std::find_if(unknown.begin(), unknown.end(),
                                   [](const std::string& word) { return word.starts_with("-"); });
  const bool is_option = dashed != unknown.end();
  const std::string given = is_option ? *dashed : unknown.front();
  const std::string word = given.substr(0, is_option ? given.find('=') : std::string::npos);
  std::vector<std::string> names;
  collect(app, is_option, names);
  const std::string hint = did_you_mean(word, names);
  if (is_option) return "There is no option " + word + "." + hint;
  if (!misses_command) return said + hint;
  return "There is no command or option " + word + "." + hint + " " + said;
}

std::string failure_message(const CLI::App* app, const CLI::Error& error) {
  return command_line_fault(*app, error) + "\nRun with --help for more information.\n";
}

}  // namespace hapticd::hints
