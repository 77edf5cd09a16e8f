// Bullet's constraint solver on compact memory.
//
// Bullet's own rows take 400 bytes each and point into three arrays; every row asks its bodies for their number of
// degrees of freedom and adds each change of velocity twice. Here the rows of a group are gathered once, without the
// side of a body that it cannot move, and swept in the same order with the same operations. In the exact form every sum is
// taken in Bullet's order, so that the results have the same bits; rows that would change nothing are passed over. The
// other form puts a square root in the place of atan2, sin and cos, and sums in another order.

#include <algorithm>
#include <cmath>
#include <vector>

#include "world.h"

namespace {

const int DOFS = 6;

// What a row does to one body: the velocity it sees, and the velocity that a unit impulse adds.
struct Side {
    double jacobian[DOFS];
    double response[DOFS];
    double *velocity;
};

struct Row {
    double rhs, cfm, inverse, applied;
    double friction;
    double lower, upper;
    int normal;  // the contact row whose impulse bounds this one
    int sides;
    Side side[2];
};

template <bool ROOT>
inline double dot(const double *a, const double *b)
{
    if (ROOT) return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]) + (a[4] * b[4] + a[5] * b[5]);
    double sum = 0;
    for (int i = 0; i < DOFS; i++) sum += a[i] * b[i];
    return sum;
}

template <bool ROOT>
inline double wanted(const Row &row)
{
    double impulse = row.rhs - row.applied * row.cfm;
    for (int s = 0; s < row.sides; s++)
        impulse -= dot<ROOT>(row.side[s].jacobian, row.side[s].velocity) * row.inverse;
    return impulse;
}

inline void apply(const Row &row, double impulse)
{
    for (int s = 0; s < row.sides; s++)
        for (int i = 0; i < DOFS; i++) row.side[s].velocity[i] += row.side[s].response[i] * impulse;
}

// Solves one row; gives the change of velocity along it.
template <bool ROOT>
inline double solve(Row &row)
{
    double impulse = wanted<ROOT>(row);
    const double sum = row.applied + impulse;
    if (sum < row.lower) {
        impulse = row.lower - row.applied;
        row.applied = row.lower;
    } else if (sum > row.upper) {
        impulse = row.upper - row.applied;
        row.applied = row.upper;
    } else {
        row.applied = sum;
    }
    apply(row, impulse);
    return impulse / row.inverse;
}

// The new impulse of one of two friction rows, which together lie outside of the cone.
inline void clip(Row &row, double sum, double bound, double &impulse)
{
    if (sum < -bound) {
        impulse = -bound - row.applied;
        row.applied = -bound;
    } else if (sum > bound) {
        impulse = bound - row.applied;
        row.applied = bound;
    } else {
        row.applied = sum;
    }
}

// Two friction rows of one contact, bounded together by a cone.
template <bool ROOT>
inline double solve_cone(Row &a, Row &b)
{
    double impulse_b = wanted<ROOT>(b);
    const double sum_b = b.applied + impulse_b;
    double impulse_a = wanted<ROOT>(a);
    const double sum_a = a.applied + impulse_a;
    if (sum_a * sum_a + sum_b * sum_b >= a.lower * b.lower) {
        double sine, cosine;
        if (ROOT) {
            const double length = std::sqrt(sum_a * sum_a + sum_b * sum_b);
            sine = length > 0 ? sum_a / length : 0;
            cosine = length > 0 ? sum_b / length : 1;
        } else {
            const double angle = btAtan2(sum_a, sum_b);
            sine = btSin(angle);
            cosine = btCos(angle);
        }
        clip(a, sum_a, btFabs(a.lower * sine), impulse_a);
        clip(b, sum_b, btFabs(b.lower * cosine), impulse_b);
    } else {
        a.applied = sum_a;
        b.applied = sum_b;
    }
    apply(a, impulse_a);
    apply(b, impulse_b);
    return impulse_a / a.inverse + impulse_b / b.inverse;
}

class CompactSolver : public btMultiBodyConstraintSolver {
public:
    explicit CompactSolver(bool root) : root_(root) {}

protected:
    btScalar solveGroupCacheFriendlyIterations(btCollisionObject **bodies, int body_count,
                                               btPersistentManifold **manifolds, int manifold_count,
                                               btTypedConstraint **constraints, int constraint_count,
                                               const btContactSolverInfo &info, btIDebugDraw *drawer) override
    {
        if (!gather(constraint_count, info)) {
            return btMultiBodyConstraintSolver::solveGroupCacheFriendlyIterations(
                bodies, body_count, manifolds, manifold_count, constraints, constraint_count, info, drawer);
        }
        for (int k = 0; k < info.m_numIterations; k++) {
            m_leastSquaresResidual = root_ ? sweep<true>() : sweep<false>();
            if (m_leastSquaresResidual <= info.m_leastSquaresResidualThreshold) break;
        }
        scatter();
        return 0;
    }

private:
    // Takes the rows over. False for what is not met here (joints, rigid bodies, links, other modes).
    bool gather(int constraint_count, const btContactSolverInfo &info)
    {
        const int cone = SOLVER_USE_2_FRICTION_DIRECTIONS;
        if (constraint_count || m_multiBodyNonContactConstraints.size() || m_tmpSolverContactConstraintPool.size() ||
            m_tmpSolverNonContactConstraintPool.size() || !(info.m_solverMode & cone) ||
            (info.m_solverMode & SOLVER_DISABLE_IMPLICIT_CONE_FRICTION) || info.m_splitImpulse ||
            m_maxOverrideNumSolverIterations > info.m_numIterations)
            return false;
        for (int i = 0; i < m_data.m_deltaVelocities.size(); i++)
            if (m_data.m_deltaVelocities[i] != 0) return false;
        moved_.clear();
        return take(m_multiBodyNormalContactConstraints, normal_) &&
               take(m_multiBodySpinningFrictionContactConstraints, spinning_) &&
               take(m_multiBodyTorsionalFrictionContactConstraints, rolling_) &&
               take(m_multiBodyFrictionContactConstraints, sliding_);
    }

    bool take(const btMultiBodyConstraintArray &from, std::vector<Row> &rows)
    {
        rows.resize(size_t(from.size()));
        for (int i = 0; i < from.size(); i++) {
            const btMultiBodySolverConstraint &c = from[i];
            Row &row = rows[size_t(i)];
            row.rhs = c.m_rhs;
            row.cfm = c.m_cfm;
            row.inverse = c.m_jacDiagABInv;
            row.applied = c.m_appliedImpulse;
            row.friction = c.m_friction;
            row.lower = c.m_lowerLimit;
            row.upper = c.m_upperLimit;
            row.normal = c.m_frictionIndex;
            row.sides = 0;
            if (!add_side(row, c.m_multiBodyA, c.m_solverBodyIdA, c.m_jacAindex, c.m_deltaVelAindex) ||
                !add_side(row, c.m_multiBodyB, c.m_solverBodyIdB, c.m_jacBindex, c.m_deltaVelBindex))
                return false;
        }
        return true;
    }

    bool add_side(Row &row, btMultiBody *body, int rigid, int at, int velocity)
    {
        if (!body) return rigid < 0;
        if (body->getNumDofs() != 0) return false;
        // A body that is fixed or moved from outside gets no velocity from a row.
        const double *response = &m_data.m_deltaVelocitiesUnitImpulse[at];
        if (std::all_of(response, response + DOFS, [](double v) { return v == 0; })) return true;
        Side &side = row.side[row.sides++];
        std::copy_n(&m_data.m_jacobians[at], DOFS, side.jacobian);
        std::copy_n(response, DOFS, side.response);
        side.velocity = &m_data.m_deltaVelocities[velocity];
        const Moved moved = {body, velocity};
        if (std::find(moved_.begin(), moved_.end(), moved) == moved_.end()) moved_.push_back(moved);
        return true;
    }

    template <bool ROOT>
    double sweep()
    {
        double residual = 0;
        for (Row &row : normal_) {
            const double change = solve<ROOT>(row);
            residual = btMax(residual, change * change);
        }
        for (Row &row : spinning_) {
            const double bound = row.friction * normal_[size_t(row.normal)].applied;
            if (!(normal_[size_t(row.normal)].applied > 0)) continue;
            row.lower = -bound;
            row.upper = bound;
            const double change = solve<ROOT>(row);
            residual = btMax(residual, change * change);
        }
        residual = sweep_pairs<ROOT>(rolling_, false, residual);
        return sweep_pairs<ROOT>(sliding_, true, residual);
    }

    template <bool ROOT>
    double sweep_pairs(std::vector<Row> &rows, bool also_without_load, double residual)
    {
        for (size_t i = 0; i + 1 < rows.size(); i += 2) {
            Row &a = rows[i], &b = rows[i + 1];
            if (a.normal != b.normal) continue;
            const double load = normal_[size_t(a.normal)].applied;
            if (!(load > 0)) {
                // Without load a sliding pair is set to zero; one that is at zero stays there.
                if (!also_without_load || (a.applied == 0 && b.applied == 0)) continue;
            }
            a.lower = -(a.friction * load);
            a.upper = a.friction * load;
            b.lower = -(b.friction * load);
            b.upper = b.friction * load;
            const double change = solve_cone<ROOT>(a, b);
            residual = btMax(residual, change * change);
        }
        return residual;
    }

    // Gives the impulses and velocities back to where Bullet looks for them.
    void scatter()
    {
        give(normal_, m_multiBodyNormalContactConstraints);
        give(spinning_, m_multiBodySpinningFrictionContactConstraints);
        give(rolling_, m_multiBodyTorsionalFrictionContactConstraints);
        give(sliding_, m_multiBodyFrictionContactConstraints);
        for (const Moved &moved : moved_) {
            moved.body->applyDeltaVeeMultiDof2(&m_data.m_deltaVelocities[moved.velocity], 1);
            moved.body->setPosUpdated(false);
        }
    }

    static void give(const std::vector<Row> &rows, btMultiBodyConstraintArray &to)
    {
        for (size_t i = 0; i < rows.size(); i++) to[int(i)].m_appliedImpulse = rows[i].applied;
    }

    struct Moved {
        btMultiBody *body;
        int velocity;
        bool operator==(const Moved &other) const { return body == other.body; }
    };

    bool root_;
    std::vector<Row> normal_, spinning_, rolling_, sliding_;
    std::vector<Moved> moved_;
};

}  // namespace

namespace jostle_bt {

std::unique_ptr<btMultiBodyConstraintSolver> make_compact_solver(bool root)
{
    return std::unique_ptr<btMultiBodyConstraintSolver>(new CompactSolver(root));
}

}  // namespace jostle_bt
