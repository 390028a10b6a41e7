//! The frame of a vessel in the field: along its axis, upwards, across; and rotations in it.

/// A direction or place: out of the opening, upwards, across.
pub type Local = [f64; 3];

/// Right-handed, with the origin in the middle of the opening, in the frame of the field.
#[derive(Clone, Copy)]
pub struct Frame {
    /// Out of the opening.
    pub out: [f64; 3],
    /// Across it, as far upwards as that is: the opening is flat in this direction.
    pub up: [f64; 3],
    /// Across both: up × out.
    pub side: [f64; 3],
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
    a.map(|c| c / length)
}

impl Frame {
    /// A vessel whose opening looks to the right (or, mirrored, to the left), by `azimuth` towards the trainee and by `elevation` upwards \[rad\].
    pub fn new(azimuth: f64, elevation: f64, mirrored: bool) -> Self {
        let level = libm::cos(elevation);
        let x = level * libm::cos(azimuth);
        let out = [
            if mirrored { -x } else { x },
            -level * libm::sin(azimuth),
            libm::sin(elevation),
        ];
        let up = unit([0, 1, 2].map(|k| f64::from(u8::from(k == 2)) - out[2] * out[k]));
        Self {
            out,
            up,
            side: cross(up, out),
        }
    }

    /// A place or direction in the field.
    pub fn field(&self, [out, up, side]: Local) -> [f64; 3] {
        [0, 1, 2].map(|k| out * self.out[k] + up * self.up[k] + side * self.side[k])
    }

    /// The orientation of a tool whose handle lies in a direction, and whose jaws open along another one, as far as that is across.
    pub fn tool(&self, handle: Local, jaws: Local) -> [f64; 4] {
        let z = unit(self.field(handle));
        let y = unit(cross(z, self.field(jaws)));
        quaternion([cross(y, z), y, z])
    }
}

/// The rotation with these columns, as x, y, z, w.
fn quaternion([x, y, z]: [[f64; 3]; 3]) -> [f64; 4] {
    let squares = [
        1.0 + x[0] - y[1] - z[2],
        1.0 - x[0] + y[1] - z[2],
        1.0 - x[0] - y[1] + z[2],
        1.0 + x[0] + y[1] + z[2],
    ];
    // The largest one decides which root is safe.
    let k = (0..4)
        .max_by(|a, b| squares[*a].total_cmp(&squares[*b]))
        .unwrap_or(3);
    let (xy, xz, yz) = (x[1] + y[0], x[2] + z[0], y[2] + z[1]);
    let turns = [y[2] - z[1], z[0] - x[2], x[1] - y[0]];
    let mut q = match k {
        0 => [0.0, xy, xz, turns[0]],
        1 => [xy, 0.0, yz, turns[1]],
        2 => [xz, yz, 0.0, turns[2]],
        _ => [turns[0], turns[1], turns[2], 0.0],
    };
    let root = 2.0 * squares[k].sqrt();
    q = q.map(|c| c / root);
    q[k] = 0.25 * root;
    q
}
