//! explore
use microsim_scene::*;
use nalgebra::{Vector3,UnitQuaternion};
fn spec(cells:[usize;3], vertical: bool) -> SceneSpec {
    let cap = if vertical { CapsuleSpec{a:[0.0;3],b:[0.0,0.0,0.02],radius:0.5e-3,hinge:None} } else { CapsuleSpec{a:[0.0,-4e-3,0.0],b:[0.0,4e-3,0.0],radius:0.5e-3,hinge:None} };
    SceneSpec { bodies: vec![BodySpec{ name:"strip".into(), generator: Generator::Block(Block{center:[0.0;3],size:[20e-3,4e-3,1e-3],cells}),
      material: SpringVolumeSpec{stretch_modulus:25e3,volume_modulus:5e4,density:1060.0,drag:100.0},
      clamps: vec![BoxSpec{min:[-10e-3,-1.0,-1.0],max:[-10e-3,1.0,1.0]},BoxSpec{min:[10e-3,-1.0,-1.0],max:[10e-3,1.0,1.0]}] }],
      tools: vec![ToolSpec{name:"probe".into(),capsules:vec![cap]}], contact_pairs: vec![("probe".into(),"strip".into())], gravity:[0.0,0.0,-9.81] }
}
fn main(){
  for cells in [[20,4,2],[20,4,2],[20,4,1]] { for vertical in [false] {
    let mut s = Scene::new(&spec(cells,vertical)).unwrap();
    let tick=8e-3; let steps=s.required_steps(tick);
    println!("cells {cells:?} vertical {vertical} tets {} nodes {} required {steps} stable {:e}", s.element_count(0), s.positions(0).len(), s.stable_step(0));
    let t0=std::time::Instant::now();
    let n=250;
    let pose=|d:f64| Pose{position:Vector3::new(0.13e-3,0.07e-3,0.5e-3+0.5e-3+0.3e-3-d),orientation:UnitQuaternion::identity()};
    for k in 0..n { 
      let depth=|k:usize| (k as f64/150.0).min(1.0)*2.3e-3;
      let m=ToolMotion{tool:0,from:pose(depth(k)),to:pose(depth(k+1)),opening_from:0.0,opening_to:0.0,active:true};
      let r=s.tick(&[m],tick,steps,&Serial).unwrap();
      if k%250==249 { let c=r.contacts.first(); println!("{k} sub {} rec {:?} {:?}",r.substeps,r.recoveries.len(), c.map(|c|(c.force_on_tissue.map(|f|(f*1e6).round()),(c.peak_force_n*1e6).round(),c.max_depth_m,c.indentation_m,c.nodes,c.point.map(|p|(p*1e6).round())))); 
        let e=s.energies(0); println!("   E {:e} {:e} {:e}  vol {:.4}",e.kinetic,e.length,e.volume,s.volume(0)/80e-9); }
    }
    println!("cpu per sim second {:.3}", t0.elapsed().as_secs_f64()/(n as f64*tick));
  }}
}
