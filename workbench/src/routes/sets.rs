//! Addresses of the pages of data sets.

use std::path::PathBuf;
use std::sync::Arc;

use axum::extract::{Path, State};
use axum::response::{Html, Response};
use axum::routing::get;
use axum::{Json, Router};
use serde_json::Value;

use super::{Answer, Of, blocking, picture};
use crate::error::Refusal;
use crate::home::Home;
use crate::pages;
use crate::place::Kind;
use crate::sets::{Layer, SetKind, item, preview, table};

/// Adds the addresses.
pub(super) fn routes() -> Router<Arc<Home>> {
    Router::new()
        .route("/set/{id}", get(page))
        .route("/set/{id}/rows", get(rows))
        .route("/set/{id}/items/{item}", get(one))
        .route("/set/{id}/items/{item}/preview.png", get(preview_of))
        .route("/set/{id}/images/{image}/{layer}", get(layer_of))
}

/// Does work on the folder of a data set.
async fn on_set<R: Send + 'static>(
    home: Arc<Home>,
    id: String,
    work: impl FnOnce(&Home, PathBuf) -> Answer<R> + Send + 'static,
) -> Answer<R> {
    blocking(move || {
        let place = home.place(&id)?;
        if place.kind != Kind::DataSet {
            return Err(Refusal::wrong("this is no data set; go back to the list"));
        }
        work(&home, place.path)
    })
    .await
}

async fn page(State(home): Of, Path(id): Path<String>) -> Answer<Html<String>> {
    let make = move || {
        let place = home.place(&id)?;
        Ok(Html(pages::set(&place, SetKind::of(&place.path).as_ref()).into_string()))
    };
    blocking(make).await
}

async fn rows(State(home): Of, Path(id): Path<String>) -> Answer<Json<Value>> {
    let read = |home: &Home, folder: PathBuf| {
        Ok(Json(match SetKind::of(&folder)? {
            SetKind::Assets => table(&folder),
            SetKind::Images => home.images.set(&folder).table(),
        }))
    };
    on_set(home, id, read).await
}

async fn one(State(home): Of, Path((id, name)): Path<(String, String)>) -> Answer<Json<Value>> {
    on_set(home, id, move |_, folder| Ok(Json(item(&folder, &name)?))).await
}

async fn preview_of(State(home): Of, Path((id, name)): Path<(String, String)>) -> Answer<Response> {
    on_set(home, id, move |_, folder| Ok(picture(preview(&folder, &name)?))).await
}

async fn layer_of(State(home): Of, Path((id, image, layer)): Path<(String, String, Layer)>) -> Answer<Response> {
    on_set(home, id, move |home, folder| Ok(picture(home.images.set(&folder).picture(&image, layer)?))).await
}
