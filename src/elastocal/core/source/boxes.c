/* What Python calls for proofs: bounds of the sensitivity over boxes of configurations. Compiled
 * once for every instruction level, as core.c is. */
#include <stdlib.h>

#include "export.h"
#include "subtrees.h"

EXPORT int64_t NAMED(bound)(const Statement *s, int64_t count, const double *boxes, double aim,
                            double *bounds, double *values, int64_t *splits);
EXPORT int64_t NAMED(search)(const Statement *s, const double *box, double threshold,
                             double smallest, int64_t most, uint8_t *symbols, int64_t symbol_room,
                             double *boxes, int64_t box_room, Outcome *outcome);
EXPORT int64_t NAMED(leaf)(int64_t joints, const uint8_t *symbols, int64_t count,
                           const double *point, double *box);


/* Bounds (N) of the sensitivity over boxes (N, 2 n) of [0, 1]^n, its values (N) at their centres,
 * and what is to be done (N): the variable to be halved, PENDING if there is none, LEAF if the
 * bound is below `aim`, OPEN where no point of the box is allowed. */
EXPORT int64_t NAMED(bound)(const Statement *s, int64_t count, const double *boxes, double aim,
                            double *bounds, double *values, int64_t *splits) {
    void *block;
    lanes *memory = aligned(room_size(s), &block);
    if (!memory) return -1;
    Room room = room_in(s, memory);
    const int64_t n = s->joints;
    lanes box[2 * MOST_JOINTS], x[MOST_JOINTS], r[MOST_JOINTS];
    Found found;
    for (int64_t first = 0; first < count; first += LANES) {
        gather(box, boxes, first, count, 2 * n);
        box_in_x(s, box, box + n, x, r);
        bound_boxes(s, &room, x, r, aim, &found);
        scatter(bounds, &found.bound, first, count, 1);
        scatter(values, &found.value, first, count, 1);
        for (int l = 0; l < LANES && first + l < count; l++)
            splits[first + l] = found.empty[l] ? OPEN
                                : found.bound[l] <= aim ? LEAF
                                : n                     ? widest(s, &found, l)
                                                        : PENDING;
    }
    free(block);
    return 0;
}

/* Searches a box (2 n) of [0, 1]^n: see subtrees.h. */
EXPORT int64_t NAMED(search)(const Statement *s, const double *box, double threshold,
                             double smallest, int64_t most, uint8_t *symbols, int64_t symbol_room,
                             double *boxes, int64_t box_room, Outcome *outcome) {
    void *block;
    lanes *memory = aligned(room_size(s), &block);
    if (!memory) return -1;
    Room room = room_in(s, memory);
    const int64_t answer = search_box(s, &room, box, box + s->joints, threshold, smallest, most,
                                      symbols, symbol_room, boxes, box_room, outcome);
    free(block);
    return answer;
}

/* The leaf that a point of [0, 1]^n is in: its box takes the place of that of the tree. */
EXPORT int64_t NAMED(leaf)(int64_t joints, const uint8_t *symbols, int64_t count,
                           const double *point, double *box) {
    return find_leaf(joints, symbols, count, point, box, box + joints);
}
