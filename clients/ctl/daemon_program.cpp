// See daemon_program.h.
#include "clients/ctl/daemon_program.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "clients/ctl/commands.h"

namespace hapticd::ctl {
namespace {

/// How to get a program that is not beside hapticctl, which is in `folder`.
std::string remedy(const std::string& name, const std::filesystem::path& folder) {
  std::error_code unknown;
  const std::filesystem::path tree = folder.parent_path();
  if (std::filesystem::exists(tree / "CMakeCache.txt", unknown)) {
    return "Build it: cmake --build " + tree.string() + " --target installed";
  }
  return "Install " + name + " beside hapticctl, or add its folder to PATH.";
}

}  // namespace

void become_program(const std::string& name, const std::vector<std::string>& arguments) {
  std::error_code unknown;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const std::filesystem::path beside = self.parent_path() / name;
  const bool there = !unknown && access(beside.c_str(), X_OK) == 0;
  std::vector<std::string> words{there ? beside.string() : name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  std::fflush(stdout);
  execvp(pointers.front(), pointers.data());
  throw Failure(kRefused, "cannot start " + words.front() + ": " +
                              std::generic_category().message(errno) + ". " +
                              remedy(name, self.parent_path()));
}

namespace {

struct DoctorOptions {
  std::string seconds;
  std::string rate;
  std::string cpu;
};

}  // namespace

void add_doctor_command(CLI::App& app, const GlobalOptions& options) {
  CLI::App* doctor = app.add_subcommand(
      "doctor", "measures this machine and names what makes ticks late (hapticd doctor)");
  const auto asked = std::make_shared<DoctorOptions>();
  doctor->add_option("--seconds", asked->seconds, "how long to measure (10)")->type_name("N");
  doctor->add_option("--rate", asked->rate, "ticks per second (1000)")->type_name("HZ");
  doctor->add_option("--cpu", asked->cpu, "processor to measure on (any)")->type_name("N");
  doctor->callback([&options, asked] {
    std::vector<std::string> arguments{"doctor"};
    const auto add = [&](const char* name, const std::string& value) {
      if (value.empty()) return;
      arguments.emplace_back(name);
      arguments.push_back(value);
    };
    add("--seconds", asked->seconds);
    add("--rate", asked->rate);
    add("--cpu", asked->cpu);
    if (options.json) arguments.emplace_back("--json");
    become_hapticd(arguments);
  });
}

}  // namespace hapticd::ctl
