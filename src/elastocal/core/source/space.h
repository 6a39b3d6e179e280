/* The space of load cases, as plain data; `core/layout.py` has the same structures.
 *
 * Lengths in metres, angles in radians, forces in newtons, frames as in `robot/posture.py`. The
 * Python side owns all memory.
 */
#ifndef ELASTOCAL_SPACE_H
#define ELASTOCAL_SPACE_H

#include <stdint.h>

/* Which forces, or moments, may act: elastic/allowed_loads.py. */
enum { FIXED, DIRECTION, PLANE, SHARE };

typedef struct {
    int64_t kind;
    int64_t zero;      /* never anything but zero */
    int64_t cone;      /* a DIRECTION is restricted to a cone */
    double size;       /* largest norm */
    double half_angle; /* of the cone */
    double axis[3];    /* FIXED, SHARE: the vector, DIRECTION: axis of the cone */
    double basis[6];   /* PLANE: first then second vector that span it */
} Load;

/* Margins: constraints/. */
enum {
    HALF_SPACE,
    MIN_RADIUS,
    ELEVATION,
    TILT,
    JOINT_LIMIT,
    HELD_JOINT,
    BEAM_RANGE,
    ACCEPTANCE_CONE,
    HEAD_ELEVATION,
    HEAD_AZIMUTH,
    DISTINCT,
    CLEARANCE,
    LINE_OF_SIGHT,
    FOREIGN, /* known to Python alone */
};

/* A solid that one body carries: within a radius of a segment, and of the hull of its corners
 * within another one; below its faces. What it is without these bounds is the hull of its tips,
 * widened by a disc if it is round and thickened by a skin. */
typedef struct {
    int64_t body;
    double ends[6]; /* start, end, in the frame of the body */
    double radius;
    double ball;    /* radius of the ball around it */
    int64_t faces;
    const double *face; /* (faces, 4) unit normals and heights */
    int64_t corners;
    const double *corner; /* (corners, 3) far apart ones first */
    double rounded;       /* the radius about the corners */
    int64_t tips;
    const double *tip; /* (tips, 3) */
    int64_t fields;    /* along a side of the cube of directions; 0 where there are few tips */
    const int64_t *starts;   /* (6 fields² + 1) where those of a field begin ... */
    const int64_t *foremost; /* ... here: the tips that are farthest along some direction of it */
    int64_t round;
    double spokes[6]; /* two radii of the disc, square to each other */
    double skin;
} Solid;

/* What a segment is near to. */
enum { A_SEGMENT, A_PLANE, A_BOX };

/* How near it is then: as it is, by the faces, or by how far the solids reach. */
enum { AS_IT_IS, BY_FACES, BY_REACH };

typedef struct {
    int64_t kind;
    int64_t first, second; /* solids; a beam has no first, a plane no second */
    int64_t closer;        /* what may show more distance than capsules and boxes do */
    double pose[12];       /* PLANE, BOX: the axes one by one, then the origin */
    double half[3];        /* BOX: half its sides */
} Pair;

#define MOST_FACES 64
#define SENTINELS 8         /* corners that tell which face promises most */
#define NEAR_MARKER 0.05    /* constraints/line_of_sight.py: of the beam, not watched */

typedef struct {
    int64_t kind;
    int64_t at;    /* point, or joint */
    int64_t along; /* direction */
    double sign;
    double bound;
    double middle;   /* HEAD_AZIMUTH */
    double place[3]; /* normal, position of the tracker, or wanted direction */
    const double *q; /* DISTINCT: (2, joints) configuration, which joints count */
    const Pair *pairs;
    int64_t count;  /* of the pairs */
    double horizon; /* margins of distances are measured up to this */
} Margin;

/* What measures: measuring/instrument.py. */
enum { ISOTROPIC, TRACKER };

typedef struct {
    int64_t kind;
    double deviation;
    double position[3];
    double along, along_per_metre, across, across_per_metre;
    double rotation; /* standard deviation of a rotation; 0 if none is measured */
} Noise;

/* What errs in load cases besides what measures: elastic/absorbed.py. */
typedef struct {
    int64_t any;
    double discrepancy, length, gain, tilt, repeatability;
    double turning;           /* of the unknowns that turn all loads together, in their unit */
    double together;          /* repeats that share a load case where nobody says how many */
    const double *compliance; /* (c) */
    const double *rubbing;    /* (c) what friction leaves of it */
} Errors;

typedef struct {
    int64_t variables; /* d: joints, then those of force and moment */
    int64_t joints;    /* n that move on their own */
    int64_t moving;    /* n + F that move */
    int64_t last;      /* m of them on the chain */
    const double *links;     /* (moving + 1, 16) to each joint that moves, then to the flange */
    const int64_t *carriers; /* (moving + 1) body that carries the joint of each body */
    const int64_t *sliding;  /* (moving) */
    const int64_t *own;      /* (joints) where the joints are among those that move */
    const double *mixing;    /* (moving, joints); 0 if it is the identity */
    const double *standing;  /* (moving) */
    int64_t twists;          /* T */
    int64_t springs;         /* c */
    int64_t unknowns;        /* p; the last three turn all loads together if errors.turning > 0 */
    const int64_t *making;   /* (c + 1) where the unknowns of each spring begin; 0: one a spring */
    const int64_t *maker;    /* which unknowns make a spring ... */
    const double *made;      /* ... and how much of it one of each makes */
    const int64_t *body;     /* (T) which carries each twist, ascending */
    const int64_t *joint;    /* (T) moving joint whose axis it has, -1 if none */
    const double *axes;      /* (T, 3) in the frame of the body */
    const double *origins;   /* (T, 3) */
    const int64_t *slides;   /* (T) */
    const int64_t *stiff;    /* (c) of which the column is the velocity alone */
    const int64_t *only;     /* (c) the one marker that it moves, -1: all */
    int64_t weights;         /* that count as loads */
    const int64_t *heavy;    /* (weights) their bodies */
    const double *centers;   /* (weights, 3) in the frames of these */
    const double *pulls;     /* (weights, 3) forces */
    const double *share;     /* (T, c); 0 if it is the identity */
    const int64_t *carried;  /* (last) number of twists that joint does not carry */
    int64_t points;          /* on the flange, the load point first */
    const double *locals;    /* (points, 3) in the frame of the flange */
    int64_t markers;
    const int64_t *marker;    /* (markers) which of the points */
    int64_t directions;       /* of the flange that constraints look at */
    const double *pointing;   /* (directions, 3) */
    Noise noise;
    Errors errors;
    Load force, moment;
    int64_t margins;          /* C, without those of the cones */
    const Margin *margin;     /* (C) */
    int64_t solids;
    const Solid *solid;
} Space;

#endif
