#include "integrate/problems.hpp"

namespace rollerrig::test {

using Compiled = integrate::Integrator<AnySystem>;

Integrator::Integrator(AnySystem system, Options options)
    : AnySystem(std::move(system)), Compiled(static_cast<AnySystem&>(*this), std::move(options)) {}
Integrator::~Integrator() = default;

Status Integrator::start(double t0, std::vector<double> const& x0) { return Compiled::start(t0, x0.data()); }
Status Integrator::advance(double t_stop, Observer const& observer) { return Compiled::advance(t_stop, observer); }
void Integrator::sample(double t, double* x, double* z) { Compiled::sample(t, x, z); }

}  // namespace rollerrig::test
