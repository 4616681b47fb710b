"""The paper's claims: each proved, refuted by a witness, not checkable or ill-posed."""
