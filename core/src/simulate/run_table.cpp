#include "rollerrig/simulate/run_table.hpp"

#include "rollerrig/simulate/driver.hpp"

namespace rollerrig {

Status advance(Driver& driver, double t_stop, TimedRows& rows, Readings* readings) {
  return driver.advance(t_stop, [&](double t, double const* x, double const* z) {
    if (readings != nullptr) {
      if (double* const row = readings->table.add(t)) driver.record_reading(t, x, z, row);
      if (readings->shown++ % readings->every != 0) return;
    }
    if (double* const row = rows.add(t)) driver.record(t, x, z, row);
  });
}

}  // namespace rollerrig
