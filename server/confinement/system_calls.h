// The table of roles and system calls: all that a thread of a role may ask of the kernel. Numbers
// are those of the machine this is built for. Not RT.
#pragma once

#include <span>
#include <string_view>

#include "core/rt/thread_role.h"

namespace hapticd {

/// A call and its name in the manual.
struct SystemCall {
  int number = -1;
  std::string_view name;
};

/// What threads of any role may call: memory, locks, time, signals, and their own end.
[[nodiscard]] std::span<const SystemCall> calls_of_all() noexcept;
/// What those of this role may call beside it.
[[nodiscard]] std::span<const SystemCall> calls_of(ThreadRole role) noexcept;
/// The role in a word.
[[nodiscard]] std::string_view name_of(ThreadRole role) noexcept;

}  // namespace hapticd
