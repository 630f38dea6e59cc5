// Ctrl-C: a flag that the observer shows to the library.
#pragma once

namespace voropack::app {

/// From now on SIGINT and SIGTERM set a flag instead of killing the program. Writing to a closed pipe, or
/// beyond the largest size of a file that is allowed, becomes an error.
void catch_interrupts();

/// The signal that arrived, or 0. Safe from any thread.
int interrupt_signal();

}  // namespace voropack::app
