// The log as entries of the systemd journal: priority and fields to filter by, beside the text.
// Lines of spdlog become entries; log_entry() gives one fields of its own. Where the journal does
// not read this program's stderr, everything stays as spdlog writes it. Not RT.
#pragma once

#include <spdlog/common.h>

#include <string>
#include <string_view>
#include <vector>

namespace hapticd {

/// A field of an entry. Names begin with HAPTICD_, but for MESSAGE_ID (journalctl --catalog, -F).
struct LogField {
  std::string_view name;
  std::string value;
};

/// Whether stderr leads to the journal: it is the file that $JOURNAL_STREAM names
/// (systemd.exec(5)).
[[nodiscard]] bool stderr_is_journal();

/// From here on what is logged goes to the journal's socket and no longer to stderr; an entry that
/// the journal does not take goes to stderr.
void log_to_journal();

/// Every entry from here on has this field. Without a journal: nothing. From any thread.
void keep_log_field(std::string_view name, const std::string& value);

/// Logs `text`, in the journal with these fields.
void log_entry(spdlog::level::level_enum level, const std::string& text,
               const std::vector<LogField>& fields);

}  // namespace hapticd
