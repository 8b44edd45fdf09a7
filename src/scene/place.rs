//! The keys that put a mesh in its place: `matrix`, `scale`, `rotate`, `translate`.

use super::Transform;
use super::error::SceneError;
use super::table::{MAX_LENGTH, MIN_LENGTH, Table, Value};
use glam::{DAffine3, DMat3, DVec3};

const MATRIX: &str = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]";

/// The transform that a mesh's table writes: first its matrix, then scale, rotate, translate.
pub(super) fn of(table: &Table) -> Result<Transform, SceneError> {
    let scale = table.get("scale");
    let rotate = table.get("rotate").map_or(Ok(DVec3::ZERO), |value| value.vector())?;
    let translate = table.get("translate").map_or(Ok(DVec3::ZERO), |value| value.position())?;
    let matrix = table.get("matrix");
    let first = matrix.map_or(Ok(DAffine3::IDENTITY), |value| affine(&value))?;
    let factors = scale.map_or(Ok(DVec3::ONE), |value| factors(&value))?;
    let uniform = factors.x > 0.0 && factors == DVec3::splat(factors.x);
    let (scale, affine) = match uniform {
        true => (factors.x, first),
        false => (1.0, DAffine3::from_scale(factors) * first),
    };
    Transform::new(scale, rotate, translate).after(affine).ok_or_else(|| {
        let (message, remedy) = (
            "the mesh is made flat or beyond all size",
            "write a `matrix` with an inverse: no row of its first three columns may follow from the others",
        );
        matrix.map_or_else(|| table.error(message, remedy), |value| value.error(message, remedy))
    })
}

/// One factor or three, none 0.
fn factors(value: &Value) -> Result<DVec3, SceneError> {
    let sizes = MIN_LENGTH..=MAX_LENGTH;
    let rule = format!("from {MIN_LENGTH:e} to {MAX_LENGTH:e} in size, and not 0");
    let accept = |x: f64| sizes.contains(&x.abs());
    if value.is_number() {
        return value.number_where(accept, &rule).map(DVec3::splat);
    }
    let factors = value.vector()?;
    match factors.to_array().into_iter().find(|x| !accept(*x)) {
        Some(wrong) => Err(value.out_of_range(wrong, &rule)),
        None => Ok(factors),
    }
}

/// Four rows of four numbers; a point is a column with 1 as its fourth. The last row is 0, 0, 0, 1.
fn affine(value: &Value) -> Result<DAffine3, SceneError> {
    let wrong = |at: &Value, what: String| at.error(what, format!("write it as `{MATRIX}`"));
    let rows = value.items("a list of four rows", MATRIX)?;
    if rows.len() != 4 {
        return Err(wrong(value, format!("`matrix` has {} rows; four are wanted", rows.len())));
    }
    let mut m = [[0.0; 4]; 4];
    for (row, numbers) in rows.iter().zip(&mut m) {
        let items = row.items("a row of four numbers", MATRIX)?;
        if items.len() != 4 {
            return Err(wrong(
                row,
                format!("a row of `matrix` has {} numbers; four are wanted", items.len()),
            ));
        }
        for (item, number) in items.iter().zip(numbers) {
            let rule = format!("at most {MAX_LENGTH:e} in size");
            *number = item.number_where(|x| x.abs() <= MAX_LENGTH, &rule)?;
        }
    }
    if m[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err(wrong(
            &rows[3],
            "the last row of `matrix` is not 0, 0, 0, 1: such a map is no affine one".to_owned(),
        ));
    }
    let column = |k: usize| DVec3::new(m[0][k], m[1][k], m[2][k]);
    Ok(DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) })
}
