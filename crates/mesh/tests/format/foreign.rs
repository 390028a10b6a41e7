use crate::samples::*;
use microsim_mesh::format::*;
#[test]
fn emit() {
    let d = "/tmp/fetch/ours";
    std::fs::create_dir_all(d).unwrap();
    for (n, m) in [("two-cells", two_cells()), ("tube", reference_tube())] {
        let w = |e: &str, b: Vec<u8>| std::fs::write(format!("{d}/{n}{e}"), b).unwrap();
        w(".2.msh", write_gmsh_2(&m)); w(".4.msh", write_gmsh_4(&m)); w(".vtk", write_vtk_legacy(&m));
        let disp: Vec<_> = m.positions.iter().map(|p| p * 0.5).collect();
        let s: Vec<f64> = (0..m.tets.len()).map(|e| e as f64 / 3.0).collect();
        let nf = [Field { name: "displacement", values: FieldValues::Vectors(&disp) }];
        let ef = [Field { name: "stress", values: FieldValues::Scalars(&s) }];
        w(".a.vtu", write_vtu(&m, &m.positions, &nf, &ef, VtuEncoding::Ascii));
        w(".r.vtu", write_vtu(&m, &m.positions, &nf, &ef, VtuEncoding::AppendedRaw));
        let [a, b] = write_tetgen(&m); w(".node", a); w(".ele", b);
        let surf = microsim_mesh::TriangleSurface { positions: m.positions.clone(), triangles: m.surface().triangles };
        w(".obj", write_obj(&surf)); w(".a.stl", write_stl_ascii(&surf)); w(".b.stl", write_stl_binary(&surf));
        w(".pvd", write_pvd(&[PvdEntry { time: 0.0, part: 0, file: "two-cells.a.vtu" }, PvdEntry { time: 0.5, part: 0, file: "two-cells.r.vtu" }]));
    }
}
