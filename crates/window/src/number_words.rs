//! What the numbers of a level mean, in German; in English the schema states it.

/// Names and meanings, by name.
const MEANINGS: &[(&str, &str)] = &[
    (
        "area_modulus",
        "Von `scaled`-Federn: gegen Änderung der Fläche.",
    ),
    (
        "break_distance",
        "Einer Verbindung, die hält: Abstand, bei dem ein Knoten abreißt.",
    ),
    (
        "brittleness",
        "Wie früh schließende Branchen das Gewebe abklemmen, von 0, nie, wie Gummi, bis 1.",
    ),
    (
        "c01_fraction",
        "Von `mooney-rivlin`: Anteil von c01 an c10 + c01.",
    ),
    (
        "creep_rate",
        "Geschwindigkeit des plastischen Fließens; ohne sie fließt ein Kontinuum sofort.",
    ),
    ("density", "Masse je Volumen."),
    (
        "drag",
        "Widerstand je Masse: Ein freier Körper verliert seine Geschwindigkeit in diesem Maß.",
    ),
    (
        "energy",
        "Einer Verbindung, die haftet: Energie je Fläche, die das Ablösen kostet.",
    ),
    (
        "fibre_dispersion",
        "Von `holzapfel-gasser-ogden`: Streuung der Fasern, von 0, alle gleich gerichtet, bis 1/3, ohne Richtung.",
    ),
    (
        "fibre_exponent",
        "Von `holzapfel-gasser-ogden`: k2, wie schnell Fasern unter Zug steifer werden.",
    ),
    (
        "fibre_ratio",
        "Von `transversely-isotropic`: Elastizitätsmodul längs der Fasern durch den der Grundsubstanz.",
    ),
    (
        "fibre_stiffness",
        "Von `holzapfel-gasser-ogden`: k1, Steifigkeit jeder der beiden Faserscharen.",
    ),
    (
        "force_limit",
        "Kraft, Mittel der letzten 50 ms, ab der die Zeit zu großer Kraft gezählt wird.",
    ),
    ("friction", "Reibungszahl, für Haften und Gleiten."),
    ("full", "Wert, ab dem es 100 Punkte gibt."),
    (
        "gap",
        "Länger ohne gültige Lage, und die Bewegung zerfällt in zwei Abschnitte.",
    ),
    (
        "hand_force",
        "Größte Kraft, mit der die Hand ein Instrument gegen etwas drückt; darüber bleibt es hinter der Hand zurück.",
    ),
    (
        "hardening",
        "Zunahme der Steifigkeit je plastischer Dehnung.",
    ),
    (
        "idle_smoothing",
        "Glättung der Orte vor dem Ruheanteil: Standardabweichung der Gaußkurve.",
    ),
    ("idle_speed", "Langsamer gilt ein Instrument als ruhend."),
    ("max", "Größter Wert, der besteht."),
    (
        "max_stiffening",
        "Größter Faktor der Steifigkeit beim Verfestigen.",
    ),
    ("max_strain", "Größte plastische Dehnung."),
    ("min", "Kleinster Wert, der besteht."),
    (
        "movement_speed",
        "Jede Überschreitung zählt als eine Bewegung, mit einer Hysterese von der Hälfte.",
    ),
    (
        "poisson_ratio",
        "Querdehnungszahl; 0,5 wäre inkompressibel.",
    ),
    (
        "pressure",
        "Druck gegen die Außennormale der verformten Oberfläche.",
    ),
    (
        "ramp",
        "Zeit, in der eine Last auf ihren vollen Wert wächst.",
    ),
    (
        "relaxation_time",
        "Kelvin-Voigt-Dämpfung: Eine Dehnrate widersteht wie diese Dehnung mal dieser Zeit.",
    ),
    (
        "resample_rate",
        "Rate, mit der Abschnitte gleichmäßig abgetastet werden.",
    ),
    (
        "shear_strength",
        "Einer Verbindung, die gleitet: Kraft je Fläche quer dazu, die sie außerdem trägt.",
    ),
    (
        "shortest_path",
        "Länge des kürzesten sinnvollen Wegs, für die Bewegungsökonomie.",
    ),
    (
        "smoothing",
        "Glättung der Orte vor Bewegungen und Korrelation: Standardabweichung der Gaußkurve.",
    ),
    (
        "stiffness",
        "Einer Verbindung: Kraft je Abstand und Fläche; eines Kontakts mit `penalty`: Kraft je Eindringtiefe.",
    ),
    (
        "strength",
        "Einer Verbindung, die haftet: Kraft je Fläche, ab der sie nachgibt.",
    ),
    (
        "stretch_modulus",
        "Von `scaled`-Federn: gegen Änderung der Länge.",
    ),
    (
        "tear_strain",
        "Dehnung quer zu einer Ebene, bei der das Gewebe von selbst reißt.",
    ),
    (
        "toughness",
        "Kraft je Länge einer ideal scharfen Schneide, die es schneidet.",
    ),
    (
        "viscosity",
        "Kelvin-Voigt-Dämpfung bei einachsigem Zug, statt `relaxation_time`.",
    ),
    (
        "volume_modulus",
        "Von `scaled`-Federn: gegen Änderung des Volumens.",
    ),
    (
        "yield_growth",
        "Eines Kontinuums: Zunahme der Fließdehnung je plastischer Dehnung.",
    ),
    (
        "yield_strain",
        "Dehnung, ab der das Gewebe plastisch fließt.",
    ),
    ("youngs_modulus", "Elastizitätsmodul."),
    ("zero", "Wert, ab dem es keine Punkte mehr gibt."),
];

/// What a number of this name means, in German.
pub fn in_german(name: &str) -> Option<&'static str> {
    let place = MEANINGS.binary_search_by(|(known, _)| (*known).cmp(name));
    place.ok().map(|place| MEANINGS[place].1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_settings::number_names;

    #[test]
    fn each_number_of_the_schema_is_explained_and_nothing_else() {
        let known: Vec<&str> = MEANINGS.iter().map(|(name, _)| *name).collect();
        assert_eq!(known, number_names());
        assert_eq!(in_german("youngs_modulus"), Some("Elastizitätsmodul."));
        assert_eq!(in_german("colour"), None);
    }
}
