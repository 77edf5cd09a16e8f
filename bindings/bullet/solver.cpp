#include "world.h"

namespace jostle_bt {

std::unique_ptr<btMultiBodyConstraintSolver> make_compact_solver(bool)
{
    return std::unique_ptr<btMultiBodyConstraintSolver>(new btMultiBodyConstraintSolver);
}

}  // namespace jostle_bt
