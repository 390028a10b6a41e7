//! Parts of a mesh that are to be refined, as the command line gives them.

use microsim_mesh::Zone;

/// The zone that a text describes: `X,Y,Z,R`, `segment:X,Y,Z,X,Y,Z,R`, `plane:X,Y,Z,NX,NY,NZ,D` or `region:N`.
pub fn parse_zone(text: &str) -> Result<Zone, String> {
    let known = "expected X,Y,Z,R (a point and a radius), segment:X,Y,Z,X,Y,Z,R, plane:X,Y,Z,NX,NY,NZ,D or region:N";
    let (kind, numbers) = text.split_once(':').unwrap_or(("point", text));
    if kind == "region" {
        let region = numbers.trim().parse();
        return region.map(Zone::Region).map_err(|_| known.to_owned());
    }
    let numbers = numbers.split(',').map(|number| number.trim().parse());
    let numbers: Result<Vec<f64>, _> = numbers.collect();
    match (kind, numbers.as_deref()) {
        ("point", Ok([x, y, z, radius])) => Ok(Zone::Ball {
            center: [*x, *y, *z],
            radius: *radius,
        }),
        ("segment", Ok([x, y, z, to_x, to_y, to_z, radius])) => Ok(Zone::Capsule {
            ends: [[*x, *y, *z], [*to_x, *to_y, *to_z]],
            radius: *radius,
        }),
        ("plane", Ok([x, y, z, nx, ny, nz, distance])) => Ok(Zone::Slab {
            point: [*x, *y, *z],
            normal: [*nx, *ny, *nz],
            distance: *distance,
        }),
        _ => Err(known.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zones_are_parsed_or_refused_with_what_is_possible() {
        let ball = Zone::Ball {
            center: [-1.0, 2e-3, 0.0],
            radius: 0.5,
        };
        assert_eq!(parse_zone("-1, 2e-3,0,.5"), Ok(ball));
        assert_eq!(parse_zone("point:-1,2e-3,0,0.5"), Ok(ball));
        assert_eq!(parse_zone("region:4"), Ok(Zone::Region(4)));
        let segment = Zone::Capsule {
            ends: [[0.0; 3], [1.0, 0.0, 0.0]],
            radius: 2.0,
        };
        assert_eq!(parse_zone("segment:0,0,0,1,0,0,2"), Ok(segment));
        let plane = Zone::Slab {
            point: [0.0; 3],
            normal: [1.0, 0.0, 0.0],
            distance: 2.0,
        };
        assert_eq!(parse_zone("plane:0,0,0,1,0,0,2"), Ok(plane));
        for bad in [
            "",
            "1,2,3",
            "1,2,3,4,5",
            "region:-1",
            "region:a",
            "sphere:1,2,3,4",
            "1,2,3,x",
        ] {
            let error = parse_zone(bad).unwrap_err();
            assert!(error.contains("expected X,Y,Z,R"), "{bad}: {error}");
        }
    }
}
