// hapticd export: a recording as a table, CSV or NPY, one row per tick or per event. Not RT.
#pragma once

namespace hapticd {

/// `hapticd export`, its arguments beginning with "export". Prints what is wrong; returns the exit
/// code, those of hapticd.
int run_export(int argc, const char* const* argv);

}  // namespace hapticd
