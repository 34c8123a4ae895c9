// See command_line_fault.h.
#include "proto/hints/command_line_fault.h"

#include <algorithm>
#include <cctype>
#include <regex>
#include <sstream>
#include <vector>

#include "proto/hints/nearest_name.h"

namespace hapticd::hints {
namespace {

/// `app` and the commands that were given, from the outermost inwards.
std::vector<const CLI::App*> given_commands(const CLI::App& app) {
  std::vector<const CLI::App*> given{&app};
  for (std::size_t k = 0; k < given.size(); ++k) {
    const auto below = given[k]->get_subcommands();
    given.insert(given.end(), below.begin(), below.end());
  }
  return given;
}

/// The option of `app`, or else of a command below it; null: there is none.
const CLI::Option* option_of(const CLI::App& app, const std::string& name) {
  std::vector<const CLI::App*> apps{&app};
  for (std::size_t k = 0; k < apps.size(); ++k) {
    const CLI::Option* const option = apps[k]->get_option_no_throw(name);
    if (option != nullptr) return option;
    const std::vector<const CLI::App*> below = apps[k]->get_subcommands({});
    apps.insert(apps.end(), below.begin(), below.end());
  }
  return nullptr;
}

/// Options, without their dashes, or commands, of `app` alone.
std::vector<std::string> names_in(const CLI::App& app, bool options) {
  std::vector<std::string> names;
  if (options) {
    for (const CLI::Option* option : app.get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back(name);
    }
  } else {
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  }
  return names;
}

/// The nearest option of the innermost command that has one: there it can be written. Dashes make
/// no name like another.
std::string option_hint(const CLI::App& app, const std::string& word) {
  const std::size_t dashes = word.find_first_not_of('-');
  if (dashes == std::string::npos) return {};
  const std::vector<const CLI::App*> given = given_commands(app);
  for (auto at = given.rbegin(); at != given.rend(); ++at) {
    const std::string name = nearest_name(word.substr(dashes), names_in(**at, true));
    if (!name.empty()) return " Did you mean --" + name + "?";
  }
  return {};
}

/// The nearest command of the innermost one that has one; else the option that has this name.
std::string command_hint(const CLI::App& app, const std::string& word) {
  const std::vector<const CLI::App*> given = given_commands(app);
  std::string hint;
  for (auto at = given.rbegin(); at != given.rend() && hint.empty(); ++at) {
    hint = did_you_mean(word, names_in(**at, false));
    // Where a command has to follow, one of those around it cannot.
    if (!(*at)->get_subcommands({}).empty()) break;
  }
  for (auto at = given.rbegin(); at != given.rend() && hint.empty(); ++at) {
    const std::vector<std::string> options = names_in(**at, true);
    const bool is_one = std::find(options.begin(), options.end(), word) != options.end();
    if (is_one) hint = " Did you mean --" + word + "?";
  }
  return hint;
}

/// Whether `text` has `word`, and not as a part of a longer one.
bool has_word(const std::string& text, const std::string& word) {
  const auto is_part = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; };
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    const bool ends = end == text.size() || !(is_part(text[end]) || text[end] == '-');
    if (ends && (at == 0 || !is_part(text[at - 1]))) return true;
  }
  return false;
}

/// Whether `said` is of an option, or an argument, that takes whole numbers.
bool is_of_whole_number(const CLI::App& app, const std::string& said) {
  for (const CLI::App* command : given_commands(app)) {
    for (const CLI::Option* option : command->get_options()) {
      const std::string type = option->get_type_name();
      const bool whole = type.starts_with("INT") || type.starts_with("UINT") || type == "N";
      if (whole && has_word(said, option->get_name())) return true;
    }
  }
  return false;
}

/// What to write for the number with a decimal comma in `said`; empty where there is none.
std::string comma_hint(const CLI::App& app, const std::string& said) {
  std::smatch number;
  if (!std::regex_search(said, number, std::regex("([0-9]+),([0-9]+)"))) return {};
  // That was said.
  if (said.find("is not a whole number") != std::string::npos) return {};
  if (is_of_whole_number(app, said)) return " Give a whole number.";
  const bool may_be_thousands = number.length(2) == 3 && number.str(1) != "0";
  if (may_be_thousands) return " Give a number without commas.";
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
    return said + choice_hint(said) + comma_hint(app, said);
  }
  const bool misses_command = is(CLI::ExitCodes::RequiredError);
  if (unknown.empty() || !(misses_command || is(CLI::ExitCodes::ExtrasError))) return said;
  const auto dashed = std::find_if(unknown.begin(), unknown.end(),
                                   [](const std::string& word) { return word.starts_with("-"); });
  const bool is_option = dashed != unknown.end();
  const std::string given = is_option ? *dashed : unknown.front();
  const std::string word = given.substr(0, is_option ? given.find('=') : std::string::npos);
  if (is_option) return "There is no option " + word + "." + option_hint(app, word);
  const std::string hint = command_hint(app, word);
  return misses_command ? "There is no command or option " + word + "." + hint : said + hint;
}

std::string fault_of_empty_option(const CLI::App& app, std::span<const char* const> words) {
  for (const std::string word : words) {
    if (word == "--") break;
    if (!word.starts_with("--") || !word.ends_with('=')) continue;
    const std::string name = word.substr(0, word.size() - 1);
    const CLI::Option* const option = option_of(app, name);
    if (option == nullptr || option->get_items_expected_max() == 0) continue;
    const std::string type = option->get_type_name();
    // Behind it stand the choices, which the type's name has too.
    std::string fault = name;
    fault.append(": the value is missing. Give ").append(name).append(" ");
    return fault.append(type, 0, type.find(":{")).append(".");
  }
  return {};
}

std::string failure_message(const CLI::App* app, const CLI::Error& error) {
  return command_line_fault(*app, error) + "\nRun with --help for more information.\n";
}

}  // namespace hapticd::hints
