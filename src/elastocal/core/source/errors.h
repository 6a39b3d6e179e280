/* Rows of load cases that err: turned until all that errs is independent and of size one, as
 * elastic/absorbed.py does. Included by chain.h, between what measures and the rows.
 */
#ifndef ELASTOCAL_ERRORS_H
#define ELASTOCAL_ERRORS_H

/* A vector at a target in units of its noise. */
INLINE vector whitened_at(const Space *s, const Place *p, int64_t target, vector v) {
    if (target < s->markers) return whitened(s, p, target, v);
    return times(every(1.0 / s->noise.rotation), v);
}

INLINE vector along_axis(int64_t i) {
    const double axis[] = {i == 0, i == 1, i == 2};
    return constant(axis);
}

/* What a unit load on a spring moves at a target. */
INLINE vector moved_at(const Space *s, const Place *p, int64_t target, int64_t spring) {
    if (target == s->markers) return p->turn[spring];
    return p->velocity[s->marker[target] * s->springs + spring];
}

/* Columns of all that errs. */
static void place_errors(const Space *s, Place *p) {
    const Errors *size = &s->errors;
    Erring *e = &p->erring;
    const int64_t width = targets(s);
    const lanes shared = root(e->repeats);
    const vector zero = {every(0.0), every(0.0), every(0.0)};
    for (int64_t i = 0; i < width; i++) e->total[i] = zero;
    for (int64_t i = 0; i < 3 * width; i++) e->turned[i] = zero;
    for (int64_t u = 0; u < s->springs; u++) {
        const double k = size->compliance[u];
        if (k == 0.0) continue;
        for (int64_t t = 0; t < width; t++) {
            vector part = times(k * p->exerted[u], moved_at(s, p, t, u));
            e->total[t] = plus(e->total[t], part);
            if (size->rubbing[u] == 0.0) continue;
            part = times(size->rubbing[u] / k * shared, part);
            e->rubbed[u * width + t] = whitened_at(s, p, t, part);
        }
        for (int64_t i = 0; turning(s) && i < 3; i++) {
            vector axis = along_axis(i);
            lanes exerted = dot(p->velocity[u], cross(axis, p->force));
            if (!s->moment.zero) exerted += dot(p->turn[u], cross(axis, p->moment));
            e->exerted[i * s->springs + u] = exerted;
            for (int64_t t = 0; t < width; t++) {
                vector part = times(k * exerted, moved_at(s, p, t, u));
                e->turned[i * width + t] = plus(e->turned[i * width + t], part);
            }
        }
    }
    lanes square = every(0.0);
    for (int64_t t = 0; t < s->markers; t++) square += dot(e->total[t], e->total[t]);
    square *= 1.0 / (double)s->markers;
    const double share = size->discrepancy * size->discrepancy;
    e->root[0] = root(e->repeats * (share * square + size->length * size->length));
    if (width > s->markers)
        e->root[1] = root(e->repeats * share * dot(e->total[s->markers], e->total[s->markers]));
    for (int64_t t = 0; t < width; t++) {
        e->gained[t] = times(every(size->gain), whitened_at(s, p, t, e->total[t]));
        for (int64_t i = 0; turning(s) && i < 3; i++) {
            vector column = whitened_at(s, p, t, e->turned[i * width + t]);
            e->tilted[i * width + t] = times(every(size->tilt), column);
            if (size->turning > 0.0)
                p->rows[(t + 1) * s->unknowns - 3 + i] = times(every(size->turning), column);
        }
        for (int64_t i = 0; i < 3; i++) {
            vector axis = along_axis(i);
            e->wide[3 * t + i] = whitened_at(s, p, t, times(e->root[t == s->markers], axis));
            if (t < s->markers)
                e->back[i * s->markers + t] =
                    whitened_at(s, p, t, times(every(size->repeatability), axis));
        }
    }
}

/* Adds b bᵀ, of a column over so many numbers from the first on, to the lower triangle. */
INLINE void add_column(lanes *covariance, int64_t rows, int64_t first, int64_t count,
                       const lanes *column) {
    for (int64_t i = 0; i < count; i++)
        for (int64_t j = 0; j <= i; j++)
            covariance[(first + i) * rows + first + j] += column[i] * column[j];
}

/* The numbers of an unknown, one below the other, and back. */
INLINE void take_column(const vector *rows, int64_t width, int64_t unknowns, lanes *column) {
    for (int64_t t = 0; t < width; t++) memcpy(column + 3 * t, rows + t * unknowns, sizeof *rows);
}
INLINE void put_column(vector *rows, int64_t width, int64_t unknowns, const lanes *column) {
    for (int64_t t = 0; t < width; t++) memcpy(rows + t * unknowns, column + 3 * t, sizeof *rows);
}

/* L⁻ᵀ times a column, in place. */
INLINE void solve_back(const lanes *factor, int64_t rows, lanes *column) {
    for (int64_t i = rows - 1; i >= 0; i--) {
        column[i] *= factor[i * rows + i];
        for (int64_t k = 0; k < i; k++) column[k] -= factor[i * rows + k] * column[i];
    }
}

/* The rows in units of all that errs. */
static void absorb(const Space *s, Place *p) {
    const Errors *size = &s->errors;
    const int64_t rows = rows_of(s), width = targets(s), positions = 3 * s->markers;
    Erring *e = &p->erring;
    lanes *f = e->factor;
    place_errors(s, p);
    for (int64_t i = 0; i < rows * rows; i++) f[i] = every(0.0);
    for (int64_t i = 0; i < rows; i++) f[i * rows + i] = every(1.0);
    for (int64_t u = 0; u < s->springs; u++)
        if (size->rubbing[u] != 0.0)
            add_column(f, rows, 0, rows, (lanes *)(e->rubbed + u * width));
    if (size->gain > 0.0) add_column(f, rows, 0, rows, (lanes *)e->gained);
    for (int64_t i = 0; i < 3; i++) {
        if (size->tilt > 0.0) add_column(f, rows, 0, rows, (lanes *)(e->tilted + i * width));
        if (size->repeatability > 0.0)
            add_column(f, rows, 0, positions, (lanes *)(e->back + i * s->markers));
        for (int64_t t = 0; t < width; t++)
            add_column(f, rows, 3 * t, 3, (lanes *)(e->wide + 3 * t + i));
    }
    for (int64_t i = 0; i < rows; i++)
        for (int64_t j = 0; j <= i; j++) {
            lanes sum = f[i * rows + j];
            for (int64_t k = 0; k < j; k++) sum -= f[i * rows + k] * f[j * rows + k];
            f[i * rows + j] = i == j ? 1.0 / root(sum) : sum * f[j * rows + j];
        }
    for (int64_t u = 0; u < s->unknowns; u++) {
        lanes *column = e->column;
        take_column(p->rows + u, width, s->unknowns, column);
        for (int64_t k = 0; k < rows; k++) { /* by columns: nothing waits for a sum */
            column[k] *= f[k * rows + k];
            for (int64_t i = k + 1; i < rows; i++) column[i] -= f[i * rows + k] * column[k];
        }
        put_column(p->rows + u, width, s->unknowns, column);
    }
}

/* Gradients in what errs, and in the rows before they were turned. */
typedef struct {
    vector *rows;      /* (targets, p) */
    vector *rubbed;    /* (c, targets) */
    vector *gained;    /* (targets) */
    vector *total;     /* (targets) in the deflection itself */
    vector *turned;    /* (3, targets) in that of turned loads */
} ErringBars;

/* Memory of `pull_absorbed`, in lanes. */
static int64_t erring_pull_size(const Space *s) {
    const int64_t t = targets(s);
    if (!s->errors.any) return 0;
    return 3 * t * (s->unknowns + 2 + s->springs + 1 + 1 + 3 + 1) + 9 * t * t;
}

/* Q b, for a column over so many numbers from the first on; Q is kept column by column. */
INLINE void times_matrix(const lanes *q, int64_t rows, int64_t first, int64_t count,
                         const lanes *column, lanes *to) {
    for (int64_t i = 0; i < rows; i++) to[i] = every(0.0);
    for (int64_t k = 0; k < count; k++)
        for (int64_t i = 0; i < rows; i++) to[i] += q[(first + k) * rows + i] * column[k];
}

/* What a gradient in a column of a target, in units of its noise, is in the column itself; how that
 * noise changes with the place of the marker pushes on the flange. */
INLINE vector pull_column(const Space *s, const Place *p, int64_t target, vector plain, vector bar,
                          wrench *on) {
    if (target < s->markers && s->noise.kind == TRACKER) {
        vector at = p->at[s->marker[target]];
        vector moved = pull_whitened(s, p, target, plain, bar), *force = &on[s->last].force;
        *force = plus(*force, moved);
        on[s->last].moment = plus(on[s->last].moment, cross(at, moved));
    }
    return whitened_at(s, p, target, bar);
}

/* Back through `absorb`: from gradients (targets, p) in the rows, of a scalar of rowsᵀ rows. */
static ErringBars pull_absorbed(const Space *s, const Place *p, const vector *bars, wrench *on,
                                lanes *memory) {
    const Errors *size = &s->errors;
    const Erring *e = &p->erring;
    const int64_t rows = rows_of(s), width = targets(s), unknowns = s->unknowns;
    const lanes *f = e->factor, shared = root(e->repeats);
    ErringBars b;
    b.rows = (vector *)memory, memory += 3 * width * unknowns;
    lanes *pulled = memory, *white = memory + rows; /* columns of Z and Y */
    memory += 2 * rows;
    b.rubbed = (vector *)memory, memory += 3 * s->springs * width;
    b.gained = (vector *)memory, memory += 3 * width;
    b.total = (vector *)memory, memory += 3 * width;
    b.turned = (vector *)memory, memory += 9 * width;
    vector *column = (vector *)memory;
    memory += 3 * width;
    lanes *q = memory; /* -Z Yᵀ, twice the gradient in the covariance */
    for (int64_t i = 0; i < rows * rows; i++) q[i] = every(0.0);
    for (int64_t u = 0; u < unknowns; u++) {
        take_column(bars + u, width, unknowns, pulled);
        take_column(p->rows + u, width, unknowns, white);
        solve_back(f, rows, pulled);
        solve_back(f, rows, white);
        put_column(b.rows + u, width, unknowns, pulled);
        for (int64_t j = 0; j < rows; j++)
            for (int64_t i = 0; i < rows; i++) q[j * rows + i] -= pulled[i] * white[j];
    }
    for (int64_t u = 0; u < s->springs; u++) {
        if (size->rubbing[u] == 0.0) continue;
        lanes *to = (lanes *)(b.rubbed + u * width);
        times_matrix(q, rows, 0, rows, (lanes *)(e->rubbed + u * width), to);
        const lanes scale = size->rubbing[u] * shared;
        for (int64_t i = 0; i < rows; i++) to[i] *= scale;
    }
    times_matrix(q, rows, 0, rows, (lanes *)e->gained, (lanes *)b.gained);
    for (int64_t t = 0; t < width; t++) b.gained[t] = times(every(size->gain), b.gained[t]);
    for (int64_t i = 0; turning(s) && i < 3; i++) {
        times_matrix(q, rows, 0, rows, (lanes *)(e->tilted + i * width), (lanes *)column);
        for (int64_t t = 0; t < width; t++) {
            vector bar = times(every(size->tilt), column[t]);
            if (size->turning > 0.0)
                bar = plus(bar, times(every(size->turning), b.rows[(t + 1) * unknowns - 3 + i]));
            b.turned[i * width + t] =
                pull_column(s, p, t, e->turned[i * width + t], bar, on);
        }
    }
    lanes widened[2] = {every(0.0), every(0.0)};
    for (int64_t i = 0; i < 3; i++) {
        for (int64_t t = 0; t < width; t++) {
            times_matrix(q, rows, 3 * t, 3, (lanes *)(e->wide + 3 * t + i), (lanes *)column);
            const lanes deviation = e->root[t == s->markers];
            vector axis = along_axis(i);
            vector bar = pull_column(s, p, t, times(deviation, axis), column[t], on);
            widened[t == s->markers] += dot(axis, bar);
        }
        if (size->repeatability <= 0.0) continue;
        times_matrix(q, rows, 0, 3 * s->markers, (lanes *)(e->back + i * s->markers),
                     (lanes *)column);
        for (int64_t t = 0; t < s->markers; t++)
            pull_column(s, p, t, times(every(size->repeatability), along_axis(i)), column[t], on);
    }
    const double share = size->discrepancy * size->discrepancy;
    for (int64_t t = 0; t < width; t++) {
        const int kind = t == s->markers;
        const double many = kind ? 1.0 : (double)s->markers;
        lanes slope = pick(e->root[kind] > 0.0, share * e->repeats / e->root[kind], every(0.0));
        b.total[t] = times(widened[kind] * slope / many, e->total[t]);
    }
    return b;
}

/* What the errors add to the gradient in the row of a spring, in units of the noise. */
INLINE vector erring_row(const Space *s, const ErringBars *b, int64_t target, int64_t spring) {
    const double k = s->errors.compliance[spring];
    vector bar = times(every(k), b->gained[target]);
    if (s->errors.rubbing[spring] != 0.0)
        bar = plus(bar, b->rubbed[spring * targets(s) + target]);
    return bar;
}

/* The same in the row itself. */
INLINE vector erring_plain(const Space *s, const ErringBars *b, int64_t target, int64_t spring) {
    return times(every(s->errors.compliance[spring]), b->total[target]);
}

/* What loads that are turned add to the gradients in the velocities of a spring, its turn, force
 * and moment. */
INLINE void pull_turned(const Space *s, const Place *p, const ErringBars *b, int64_t spring,
                        vector *point_bar, vector *turn_bar, vector *force_bar,
                        vector *moment_bar) {
    const lanes k = every(s->errors.compliance[spring]);
    const int64_t width = targets(s);
    if (s->errors.compliance[spring] == 0.0) return;
    for (int64_t i = 0; i < 3; i++) {
        const lanes exerted = k * p->erring.exerted[i * s->springs + spring];
        const vector axis = along_axis(i);
        lanes bar = every(0.0);
        for (int64_t t = 0; t < width; t++) {
            vector given = b->turned[i * width + t];
            bar += dot(moved_at(s, p, t, spring), given);
            vector *to = t == s->markers ? turn_bar : &point_bar[s->marker[t]];
            *to = plus(*to, times(exerted, given));
        }
        bar *= k;
        point_bar[0] = plus(point_bar[0], times(bar, cross(axis, p->force)));
        *force_bar = plus(*force_bar, times(bar, cross(p->velocity[spring], axis)));
        if (s->moment.zero) continue;
        *turn_bar = plus(*turn_bar, times(bar, cross(axis, p->moment)));
        *moment_bar = plus(*moment_bar, times(bar, cross(p->turn[spring], axis)));
    }
}

#endif
